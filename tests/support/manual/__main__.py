"""`make docs`: what the manual takes from the code, written anew."""

from __future__ import annotations

from support.manual.pages import pages, renewed

for page in pages():
    text = renewed(page.text)
    if text != page.text:
        page.path.write_text(text, encoding="utf-8")
        print(f"{page.path} written")
