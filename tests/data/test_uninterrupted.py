import os
import signal
import threading

import pytest

from fretwear.data.safe import uninterrupted


class AskedError(Exception):
    """What the handlers of these tests raise."""


@pytest.fixture
def handlers():
    def ask(number, _):
        raise AskedError(number)

    before = {each: signal.signal(each, ask) for each in (signal.SIGINT, signal.SIGTERM)}
    yield ask
    for each, handler in before.items():
        signal.signal(each, handler)


@pytest.mark.parametrize("asked", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_until_the_work_is_done(handlers, asked):
    done = []

    def work():
        with uninterrupted():
            os.kill(os.getpid(), asked)
            done.append("all")
        done.append("more")

    with pytest.raises(AskedError) as error:
        work()
    assert error.value.args == (asked,)
    assert done == ["all"]
    assert signal.getsignal(asked) is handlers


def test_nested_work_is_done_to_the_outermost_end(handlers):
    done = []

    def work():
        with uninterrupted():
            with uninterrupted():
                signal.raise_signal(signal.SIGINT)
            done.append("outer")

    with pytest.raises(AskedError):
        work()
    assert done == ["outer"]
    assert signal.getsignal(signal.SIGINT) is handlers


def test_without_a_signal_nothing_happens(handlers):
    with uninterrupted():
        pass
    assert signal.getsignal(signal.SIGTERM) is handlers


def test_a_failure_of_the_work_is_told(handlers):
    with pytest.raises(ValueError, match="work"), uninterrupted():
        raise ValueError("work")
    assert signal.getsignal(signal.SIGINT) is handlers


def test_other_threads_have_nothing_to_put_off():
    entered = []

    def work():
        with uninterrupted():
            entered.append(signal.getsignal(signal.SIGINT))

    expected = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert entered == [expected]
