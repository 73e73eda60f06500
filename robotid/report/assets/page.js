"use strict";
// Signals over time, drawn as SVG from the numbers beside each figure. Strips of a figure share their time: drag to
// zoom in, wheel (once the plot has the focus, or with Ctrl) or pinch to zoom, Alt and wheel to zoom the values, Shift
// and drag or one finger to pan, double click for all of it; arrows, + - and 0 do the same. All figures of one record
// show the same time and the same cursor. A bin of a curve, clicked, marks when the records are in it. Tables sort by
// their heads and can be saved.
(() => {
  const LEFT = 58, RIGHT = 10, TOP = 20, BOTTOM = 34, STRIP = 84, LEAST = 4;

  function unpack(text) {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
    const view = new DataView(bytes.buffer), values = new Float32Array(bytes.length / 4);
    for (let i = 0; i < values.length; i++) values[i] = view.getFloat32(4 * i, true);
    return values;
  }

  // Round numbers between two, about so many of them, and not fewer than `least`.
  function ticks(low, high, most, least = 1) {
    const rough = (high - low) / Math.max(1, most), power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= rough * 0.999);
    const found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    return found.length < least && most < 12 ? ticks(low, high, most * 1.3, least) : { step, found };
  }

  function label(value, step) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size >= 1e6 || size < 1e-4) return value.toExponential(1).replaceAll("-", "−");
    const decimals = Math.max(0, Math.min(8, Math.ceil(-Math.log10(step) - 1e-9)));
    return value.toFixed(decimals).replace("-", "−");
  }

  const exact = (value) => (Math.abs(value) >= 1e5 || (value && Math.abs(value) < 1e-3) ? value.toExponential(3) : value.toPrecision(5));

  // An element of the page or of a drawing. What is inside is text or elements, never markup: names come from files.
  function filled(made, attributes, inside) {
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...inside);
    return made;
  }
  const SVG = document.querySelector("svg")?.namespaceURI;
  const element = (tag, attributes = {}, ...inside) => filled(document.createElement(tag), attributes, inside);
  const drawn = (tag, attributes = {}, ...inside) => filled(document.createElementNS(SVG, tag), attributes, inside);

  // First index whose time is not before t.
  function index(time, t) {
    let low = 0, high = time.samples.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (time.start + time.step * time.samples[middle] < t) low = middle + 1; else high = middle;
    }
    return low;
  }

  // Indices to draw between two: all of them, or of every stretch as wide as a pixel the least and the largest.
  function extremes(values, from, to, columns) {
    const count = to - from, found = [];
    if (count <= 2 * columns) {
      for (let i = from; i < to; i++) found.push(i);
      return found;
    }
    for (let c = 0; c < columns; c++) {
      const a = from + Math.floor((c * count) / columns), b = from + Math.floor(((c + 1) * count) / columns);
      let low = a, high = a;
      for (let i = a + 1; i < b; i++) {
        if (values[i] < values[low]) low = i;
        if (values[i] > values[high]) high = i;
      }
      found.push(Math.min(low, high));
      if (low !== high) found.push(Math.max(low, high));
    }
    return found;
  }

  class Plot {
    constructor(figure, number) {
      this.number = number;
      const data = JSON.parse(figure.querySelector("script").textContent);
      this.strips = data.strips;
      this.times = data.times.map((t) => ({ ...t, samples: unpack(t.samples) }));
      for (const strip of this.strips) for (const s of strip.series) s.values = unpack(s.values);
      const ends = this.times.map((t) => t.start + t.step * t.samples[t.samples.length - 1]);
      this.all = [Math.min(...this.times.map((t) => t.start)), Math.max(...ends)];
      this.view = [...this.all];
      this.record = figure.dataset.record;
      this.marks = [];
      this.hidden = new Set();
      this.pointers = new Map();
      this.build(figure);
      this.listen();
      new ResizeObserver(() => this.ask()).observe(this.root);
      this.draw();
      figure.dataset.drawn = "yes";
      figure.plot = this;
    }

    build(figure) {
      const still = figure.querySelector(".still"), alt = still.getAttribute("aria-label");
      const tools = [["in", "+", "zoom in"], ["out", "−", "zoom out"], ["left", "←", "earlier"], ["right", "→", "later"],
        ["taller", "↕+", "zoom in on the values"], ["lower", "↕−", "zoom out of the values"], ["all", "all", "show all"]];
      this.svg = drawn("svg", { tabindex: 0, role: "img", "aria-label": `${alt} Arrow keys, plus, minus and zero move and zoom; up and down zoom the values.` });
      this.output = element("output");
      this.root = element("div", { class: "plot" },
        element("div", { class: "plot-head" },
          element("span", { class: "plot-title" }, figure.dataset.title),
          element("span", { class: "keys" }, ...this.keys()),
          element("span", { class: "tools" }, ...tools.flatMap(([act, text, title]) =>
            [element("button", { type: "button", "data-act": act, title, "aria-label": title }, text), " "]))),
        this.svg, this.output);
      still.replaceWith(this.root);
    }

    keys() {
      const seen = new Map();
      for (const strip of this.strips) for (const s of strip.series) if (s.name && !seen.has(s.name)) seen.set(s.name, s);
      return [...seen.values()].map((s) => {
        const sample = element("i");
        sample.style.borderTop = `${Math.max(2, s.width * 1.6)}px solid var(--${s.colour})`;
        return element("button", { type: "button", "aria-pressed": "true", "data-key": s.name }, sample, s.name);
      });
    }

    get span() { return this.view[1] - this.view[0]; }
    time(x) { return this.view[0] + ((x - LEFT) / this.wide) * this.span; }
    place(t) { return LEFT + ((t - this.view[0]) / this.span) * this.wide; }

    // All figures of the same record, this one among them.
    get linked() { return plots.filter((p) => p === this || (this.record && p.record === this.record)); }
    look(from, to) { for (const plot of this.linked) plot.show(from, to); }

    // Keep a view inside the record and not shorter than a few samples.
    show(from, to) {
      const [first, last] = this.all, least = LEAST * Math.min(...this.times.map((t) => t.step));
      let span = Math.min(last - first, Math.max(to - from, least));
      const start = Math.max(first, Math.min(last - span, (from + to - span) / 2));
      this.view = [start, start + span];
      this.ask();
    }
    zoom(factor, about) { this.look(about - (about - this.view[0]) * factor, about + (this.view[1] - about) * factor); }
    pan(by) { this.look(this.view[0] + by, this.view[1] + by); }
    reset() {
      for (const strip of this.strips) strip.range = null;
      this.look(...this.all);
    }
    // Zoom the values of a strip, or of all strips, about one of them.
    stretch(factor, strip, about) {
      for (const s of strip ? [strip] : this.strips) {
        const [low, high] = s.range ?? s.seen, middle = about ?? (low <= 0 && high >= 0 && s.zero ? 0 : (low + high) / 2);
        s.range = [middle - (middle - low) * factor, middle + (high - middle) * factor];
      }
      this.ask();
    }

    ask() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => { this.asked = false; this.draw(); });
    }

    draw() {
      const width = Math.max(260, this.root.clientWidth || 700);
      this.wide = width - LEFT - RIGHT;
      let y = 0;
      const parts = this.strips.map((strip, k) => {
        const tall = STRIP * strip.height * (width < 500 ? 0.8 : 1), top = y + TOP;
        y = top + tall + (k + 1 < this.strips.length ? 8 : BOTTOM);
        return this.strip(strip, top, tall, k + 1 === this.strips.length);
      });
      this.high = y;
      this.svg.setAttribute("viewBox", `0 0 ${width} ${y}`);
      this.cursor = drawn("g", { class: "cursor" });
      this.svg.replaceChildren(...parts.flat(), this.cursor);
      const whole = this.span >= (this.all[1] - this.all[0]) * (1 - 1e-9);
      for (const act of ["out", "left", "right", "all"]) {
        this.root.querySelector(`[data-act=${act}]`).disabled = whole && !(act === "all" && this.strips.some((s) => s.range));
      }
    }

    strip(strip, top, tall, last) {
      const shown = strip.series.filter((s) => !this.hidden.has(s.name)).map((s) => {
        const time = this.times[s.time];
        const from = Math.max(0, index(time, this.view[0]) - 1), to = Math.min(s.values.length, index(time, this.view[1]) + 1);
        return { s, time, at: extremes(s.values, from, to, Math.ceil(this.wide)) };
      });
      let low = strip.zero ? 0 : Infinity, high = strip.zero ? 0 : -Infinity;
      for (const { s, at } of shown) for (const i of s.ranged ? at : []) {
        if (s.values[i] < low) low = s.values[i];
        if (s.values[i] > high) high = s.values[i];
      }
      if (!(low <= high)) [low, high] = [0, 1];
      const room = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
      strip.seen = [low - room, high + room];
      [low, high] = strip.range ?? strip.seen;
      Object.assign(strip, { top, tall, low, high });
      strip.scale = (v) => top + ((high - v) / (high - low)) * tall;
      const clip = `clip-${this.number}-${top | 0}`;
      const area = drawn("rect", { x: LEFT, y: top, width: this.wide, height: tall });
      const marks = this.marks.filter(([a, b]) => b >= this.view[0] && a <= this.view[1]).map(([a, b]) => {
        const x = this.place(a);
        return drawn("rect", { class: "mark", x, y: top, width: Math.max(1, this.place(b) - x), height: tall, "clip-path": `url(#${clip})` });
      });
      return [drawn("clipPath", { id: clip }, area), ...marks, ...this.axes(low, high, strip, top, tall, last),
        ...shown.map(({ s, time, at }) => this.line(s, time, at, strip.scale, clip)),
        ...shown.filter(({ s }) => !s.ranged).flatMap((one) => this.beyond(one, strip))];
    }

    // Triangles at the edge where a curve leaves the range.
    beyond({ s, time, at }, { top, tall, low, high }) {
      const found = [];
      let before = 0;
      for (const i of at) {
        const side = s.values[i] > high ? 1 : s.values[i] < low ? -1 : 0;
        const t = time.start + time.step * time.samples[i];
        if (side && side !== before && t >= this.view[0] && t <= this.view[1]) {
          const x = this.place(t).toFixed(1), y = side > 0 ? top : top + tall;
          found.push(drawn("path", { class: "beyond", d: `M${x} ${y - 5 * side}l-4 ${5 * side}h8z`, fill: `var(--${s.colour})` }));
        }
        before = side;
      }
      return found;
    }

    axes(low, high, strip, top, tall, last) {
      const across = ticks(this.view[0], this.view[1], this.wide / 80), up = ticks(low, high, Math.max(2.5, tall / 32), 3);
      const x = across.found.flatMap((t) => {
        const at = this.place(t).toFixed(1), line = drawn("path", { d: `M${at} ${top}V${top + tall}`, stroke: "var(--grid)" });
        return last ? [line, drawn("text", { x: at, y: top + tall + 16, "text-anchor": "middle" }, label(t, across.step))] : [line];
      });
      const y = up.found.flatMap((v) => {
        const at = strip.scale(v).toFixed(1), colour = v === 0 && strip.zero ? "ink" : "grid";
        return [drawn("path", { d: `M${LEFT} ${at}H${LEFT + this.wide}`, stroke: `var(--${colour})`, "stroke-width": colour === "ink" ? 0.8 : 1 }),
          drawn("text", { x: LEFT - 6, y: at, dy: "0.35em", "text-anchor": "end" }, label(v, up.step))];
      });
      const frame = drawn("path", { d: `M${LEFT} ${top}V${top + tall}H${LEFT + this.wide}`, fill: "none", stroke: "var(--faint)" });
      const name = drawn("text", { x: LEFT, y: top - 6 }, strip.label);
      const below = last ? [drawn("text", { x: LEFT + this.wide, y: top + tall + 31, "text-anchor": "end" }, "time [s]")] : [];
      return [...x, ...y, frame, name, ...below];
    }

    line(s, time, at, scale, clip) {
      let path = "", pen = "M";
      for (const i of at) {
        if (!Number.isFinite(s.values[i])) { pen = "M"; continue; }
        path += `${pen}${this.place(time.start + time.step * time.samples[i]).toFixed(1)} ${scale(s.values[i]).toFixed(1)}`;
        pen = "L";
      }
      return drawn("path", { class: "curve", d: path, "clip-path": `url(#${clip})`, fill: "none", stroke: `var(--${s.colour})`,
        "stroke-width": s.width * 1.35, "stroke-linejoin": "round" });
    }

    // What the curves are at a time, beside a hair line.
    point(x) {
      const t = this.time(x), outside = x < LEFT || x > LEFT + this.wide;
      for (const plot of this.linked) outside ? plot.unpoint() : plot.hair(t);
    }
    hair(t) {
      const x = this.place(t);
      if (x < LEFT || x > LEFT + this.wide) return this.unpoint();
      const readings = this.strips.map((strip) => {
        const values = strip.series.filter((s) => !this.hidden.has(s.name)).map((s) => {
          const i = Math.min(s.values.length - 1, index(this.times[s.time], t));
          return `${s.name ? `${s.name} ` : ""}${exact(s.values[i])}`;
        });
        return `${strip.label}: ${values.join(", ")}`;
      });
      this.output.textContent = `${exact(t)} s · ${readings.join(" · ")}`.replace(/-(?=\d)/g, "−");
      this.cursor.replaceChildren(drawn("path", { d: `M${x} ${TOP}V${this.high - BOTTOM}`, stroke: "var(--faint)", "stroke-dasharray": "3 3" }));
    }
    unpoint() {
      this.output.textContent = "";
      this.cursor.replaceChildren();
    }
    shade(from, to) {
      const x = Math.min(from, to), wide = Math.abs(to - from);
      this.cursor.replaceChildren(drawn("rect", { x, y: TOP, width: wide, height: this.high - TOP - BOTTOM, fill: "var(--blue)", opacity: 0.18 }));
    }

    x(event) {
      const box = this.svg.getBoundingClientRect();
      return ((event.clientX - box.left) / box.width) * (this.wide + LEFT + RIGHT);
    }

    y(event) {
      const box = this.svg.getBoundingClientRect();
      return ((event.clientY - box.top) / box.height) * this.high;
    }

    listen() {
      const svg = this.svg;
      svg.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
      svg.addEventListener("pointerdown", (e) => this.down(e));
      svg.addEventListener("pointermove", (e) => this.move(e));
      for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, (e) => this.up(e));
      svg.addEventListener("pointerleave", () => this.pointers.size || this.linked.forEach((plot) => plot.unpoint()));
      svg.addEventListener("dblclick", () => this.reset());
      svg.addEventListener("keydown", (e) => this.key(e));
      this.root.addEventListener("click", (e) => this.press(e.target.closest("button")));
    }

    wheel(event) {
      const scrolls = document.activeElement !== this.svg && !event.ctrlKey && !event.metaKey;
      const outside = event.deltaY > 0 && this.span >= this.all[1] - this.all[0];
      if (event.altKey) return this.wheelValues(event);
      if (scrolls || outside) return;
      event.preventDefault();
      this.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.002))), this.time(this.x(event)));
    }

    wheelValues(event) {
      event.preventDefault();
      const y = this.y(event), strip = this.strips.find((s) => y >= s.top && y <= s.top + s.tall);
      if (!strip) return;
      const about = strip.high - ((y - strip.top) / strip.tall) * (strip.high - strip.low);
      this.stretch(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.002))), strip, about);
    }

    down(event) {
      if (event.button) return;
      this.svg.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this.x(event));
      this.from = this.x(event);
      this.grip = [...this.pointers.values()].map((x) => this.time(x));
      this.pans = event.pointerType === "touch" || event.shiftKey;
    }

    move(event) {
      const x = this.x(event);
      if (!this.pointers.has(event.pointerId)) return this.point(x);
      this.pointers.set(event.pointerId, x);
      const now = [...this.pointers.values()];
      if (now.length === 2) this.pinch(now);
      else if (this.pans) this.pan(this.grip[0] - this.time(x));
      else this.shade(this.from, x);
    }

    // Keep the two grasped times under the two fingers.
    pinch([a, b]) {
      if (Math.abs(b - a) < 10) return;
      const span = ((this.grip[1] - this.grip[0]) / (b - a)) * this.wide;
      if (!(span > 0)) return;
      const start = this.grip[0] - ((a - LEFT) / this.wide) * span;
      this.look(start, start + span);
    }

    up(event) {
      if (!this.pointers.delete(event.pointerId)) return;
      const x = this.x(event);
      if (!this.pans && event.type === "pointerup" && Math.abs(x - this.from) > 5) {
        this.look(...[this.time(this.from), this.time(x)].sort((a, b) => a - b));
      } else this.unpoint();
      this.grip = [...this.pointers.values()].map((p) => this.time(p));
    }

    key(event) {
      const acts = { ArrowLeft: "left", ArrowRight: "right", "+": "in", "=": "in", "-": "out", ArrowUp: "taller", ArrowDown: "lower", 0: "all", Home: "all", Escape: "all" };
      if (!(event.key in acts) || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.act(acts[event.key]);
    }

    act(name) {
      const middle = (this.view[0] + this.view[1]) / 2;
      if (name === "in") this.zoom(0.5, middle);
      else if (name === "out") this.zoom(2, middle);
      else if (name === "taller") this.stretch(0.5);
      else if (name === "lower") this.stretch(2);
      else if (name === "all") this.reset();
      else this.pan((name === "left" ? -0.25 : 0.25) * this.span);
    }

    press(button) {
      if (!button) return;
      if (button.dataset.act) return this.act(button.dataset.act);
      const name = button.dataset.key, hide = !this.hidden.delete(name);
      if (hide) this.hidden.add(name);
      button.setAttribute("aria-pressed", String(!hide));
      this.ask();
    }
  }

  const plots = [];
  document.querySelectorAll("figure.over-time").forEach((figure, number) => plots.push(new Plot(figure, number)));

  // Bins of a curve: clicked, they show where in time they lie.
  function unmark() {
    for (const plot of plots) if (plot.marks.length) { plot.marks = []; plot.ask(); }
    document.querySelectorAll("[data-bin].chosen").forEach((one) => one.classList.remove("chosen"));
    document.querySelectorAll(".with-bins output").forEach((one) => one.replaceChildren());
  }
  function mark(figure, bin, strip) {
    const again = strip.classList.contains("chosen"), output = figure.querySelector("output");
    unmark();
    if (again) return;
    strip.classList.add("chosen");
    for (const plot of plots) { plot.marks = bin.times[plot.record] ?? []; plot.ask(); }
    const parts = Object.entries(bin.times).flatMap(([record, times], k) => {
      const long = times.reduce((sum, [a, b]) => sum + b - a, 0), first = plots.find((plot) => plot.record === record);
      const link = first ? element("a", { href: `#${first.root.parentElement.id}` }, record) : record;
      return [k ? ", " : " ", link, ` ${exact(long)} s in ${times.length} ${times.length === 1 ? "stretch" : "stretches"} from ${exact(times[0][0])} s on`];
    });
    output.replaceChildren(`${bin.where}:`, ...(parts.length ? parts : [" in no record"]), "; marked in the figures over time.");
  }
  document.querySelectorAll("figure.with-bins").forEach((figure) => {
    const bins = JSON.parse(figure.querySelector("script").textContent).bins;
    figure.querySelector(".still").setAttribute("role", "group");
    figure.querySelector(".still").after(element("output", {}, "Click on a bin to see where in time it lies."));
    figure.querySelectorAll("[data-bin]").forEach((strip) => {
      const bin = bins[Number(strip.dataset.bin)];
      for (const [name, value] of [["role", "button"], ["tabindex", "0"], ["aria-label", bin.where]]) strip.setAttribute(name, value);
      strip.addEventListener("click", () => mark(figure, bin, strip));
      strip.addEventListener("keydown", (e) => {
        if (e.key !== "Enter" && e.key !== " ") return;
        e.preventDefault();
        mark(figure, bin, strip);
      });
    });
  });

  // Tables: sorted by a head, numbers by size, and saved as comma-separated values.
  const POWERS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const plain = (cell) => cell.textContent.trim().replace(/−/g, "-").replace(/(?<=[A-Za-z])[⁰¹²³⁴-⁹]/g, (power) => POWERS.indexOf(power));
  function sort(table, head, column) {
    const up = head.getAttribute("aria-sort") !== "ascending", body = table.tBodies[0], rows = [...body.rows];
    for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => {
      const text = plain(row.cells[column]), number = Number.parseFloat(text.replace(/^</, ""));
      return { text, number, known: Number.isFinite(number) && /^<?[-+.\d]/.test(text) };
    };
    const keyed = rows.map((row) => ({ row, ...key(row) }));
    keyed.sort((a, b) => {
      if (a.known !== b.known) return a.known ? -1 : 1;
      return (a.known ? a.number - b.number : a.text.localeCompare(b.text)) * (up ? 1 : -1);
    });
    body.append(...keyed.map((one) => one.row));
  }
  function save(table, name) {
    const cell = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
    const lines = [...table.rows].map((row) => [...row.cells].map((one) => cell(plain(one))).join(","));
    const url = URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
    element("a", { href: url, download: `${name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "")}.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }
  document.querySelectorAll("main table").forEach((table) => {
    const region = table.parentElement, name = table.caption?.textContent ?? region.getAttribute("aria-label") ?? "table";
    if (table.tHead) {
      [...table.tHead.rows[0].cells].forEach((head, column) => {
        const button = element("button", { type: "button" }, head.textContent || "name");
        button.addEventListener("click", () => sort(table, head, column));
        head.replaceChildren(button);
      });
    }
    const button = element("button", { type: "button", class: "csv", "aria-label": `${name} as CSV` }, "CSV");
    button.addEventListener("click", () => save(table, name));
    (table.caption ?? table.createCaption()).append(button);
  });

  // What is wider than the screen says so.
  const wide = () => document.querySelectorAll(".scroll, .wide .still").forEach((box) => {
    if (!box.nextElementSibling?.classList.contains("hint")) box.after(element("p", { class: "hint" }, "Scroll sideways for more →"));
    box.classList.toggle("overflows", box.scrollWidth > box.clientWidth + 4);
  });
  wide();
  addEventListener("resize", wide);
})();
