"""A signal is seen at the next safe point, at once in a blocking call, and the second one ends the process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from robotid.interrupt import Interrupted, blocking, check, interruptible


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_for_a_safe_point(number: signal.Signals) -> None:
    with interruptible():
        check()
        signal.raise_signal(number)
        with pytest.raises(Interrupted):
            check()
        check()


def test_a_blocking_call_is_left_at_once() -> None:
    began = time.monotonic()
    with interruptible():
        main = threading.main_thread().ident
        assert main is not None
        threading.Timer(0.05, signal.pthread_kill, [main, signal.SIGINT]).start()
        with pytest.raises(Interrupted), blocking():
            time.sleep(10)
    assert time.monotonic() - began < 5


def test_a_signal_before_a_blocking_call_is_not_forgotten() -> None:
    with interruptible():
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Interrupted), blocking():
            pass


def test_outside_python_s_own_interrupt_stays() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruptible():
        with interruptible():
            pass
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before
    check()


def test_what_the_shell_switched_off_stays_off() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interruptible():
            signal.raise_signal(signal.SIGINT)
            check()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_no_handler_of_errors_takes_it_for_one() -> None:
    assert not issubclass(Interrupted, Exception)


def test_in_a_thread_it_does_nothing() -> None:
    failures: list[BaseException] = []

    def work() -> None:
        try:
            with interruptible():
                check()
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert failures == []


ENDLESS = """
import os, signal, time
from robotid.interrupt import interruptible
with interruptible():
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)
    time.sleep(60)
"""


def test_the_second_signal_ends_at_once() -> None:
    done = subprocess.run([sys.executable, "-c", ENDLESS], capture_output=True, timeout=30, env=dict(os.environ))
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")


ENDING = """
import os, signal
from robotid.interrupt import interruptible
with interruptible(last=True):
    pass
os.kill(os.getpid(), signal.SIGTERM)
os.kill(os.getpid(), signal.SIGINT)
print("ended by itself")
"""


def test_a_signal_while_the_process_ends_changes_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, timeout=30, env=dict(os.environ))
    assert (done.returncode, done.stdout.strip()) == (0, b"ended by itself")
