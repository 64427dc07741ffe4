"""Workers: in what order their words come, and what they never have in their hands."""

import gc
import threading
import time
import weakref

import pytest

pytestmark = pytest.mark.usefixtures("display")


@pytest.fixture
def jobs(qtbot):
    from vtksmooth_gui.controllers.jobs import Jobs

    jobs = Jobs()
    yield jobs
    jobs.close()


def test_progress_that_is_told_faster_than_it_is_shown_holds_up_nothing(jobs, qtbot):
    from PySide6.QtCore import QTimer

    rung, turns, shown = threading.Event(), [], []

    def work(context):
        for _ in range(1000):
            context.tell(0.5, "")
            if rung.wait(0.005):
                return len(shown)
        raise AssertionError("the event loop makes no turns")

    def show(*told):
        shown.append(told)
        time.sleep(0.02)

    def turn():
        turns.append(len(shown))
        if len(turns) == 10:
            rung.set()

    timer = QTimer(interval=0)
    timer.timeout.connect(turn)
    job = jobs.start("work", work)
    job.progressed.connect(show)
    job.progressed.connect(lambda *_: timer.start())
    with qtbot.waitSignal(job.done, timeout=60_000) as done:
        pass
    timer.stop()
    assert done.args[0] > 0
    qtbot.waitUntil(lambda: jobs.idle)


def test_progress_never_comes_before_what_was_sent_before_it(jobs, qtbot):
    told, shown, seen = threading.Event(), threading.Event(), []

    def work(context):
        context.send("part")
        context.tell(0.5, "")
        told.set()
        assert shown.wait(60)

    job = jobs.start("work", work)
    job.sent.connect(seen.append)
    job.progressed.connect(lambda *_: seen.append("progress"))
    assert told.wait(60)
    job.show()  # the timer's turn, before that of the events that wait
    assert seen == ["part", "progress"]
    with qtbot.waitSignal(job.done, timeout=60_000):
        shown.set()
    assert seen == ["part", "progress"]
    qtbot.waitUntil(lambda: jobs.idle)


def test_whoever_lets_events_through_when_told_of_a_part_is_told_of_the_end_once(jobs, qtbot):
    from PySide6.QtCore import QCoreApplication

    taken, seen = threading.Event(), []

    def work(context):
        context.send("part")
        assert taken.wait(60)
        return "result"

    def take(part):
        seen.append(part)
        taken.set()
        qtbot.waitUntil(lambda: job.context.ended_at > 0.0)
        QCoreApplication.processEvents()

    job = jobs.start("work", work)
    job.sent.connect(take)
    job.done.connect(seen.append)
    qtbot.waitUntil(lambda: jobs.idle)
    assert seen == ["part", "result"]


def test_jobs_end_in_the_thread_of_the_windows(jobs, qtbot):
    """Whoever lets go of an object of Qt's last destroys it: that must not be a worker."""
    ends, gone = [], []

    def begin(number):
        job = jobs.start("work", lambda context: number)
        ends.append(weakref.ref(job, lambda _: gone.append(threading.current_thread())))

    for number in range(500):
        begin(number)
        qtbot.waitUntil(lambda: jobs.idle)
    qtbot.waitUntil(lambda: len(gone) == len(ends))
    assert set(gone) == {threading.main_thread()}


def test_garbage_is_collected_in_the_thread_of_the_windows_alone(user):
    """What is in cycles may be Qt's or VTK's: a worker must not be the one who destroys it."""

    class Node:
        pass

    where, nodes = set(), []

    def watch(phase, info):
        where.add(threading.current_thread())

    def work(context):
        for _ in range(20 * gc.get_threshold()[0]):
            node = Node()
            node.itself = node
        nodes.append(weakref.ref(node))

    gc.callbacks.append(watch)
    try:
        user.jobs.start("work", work)
        user.wait(lambda: nodes and nodes[0]() is None, timeout=10_000)
    finally:
        gc.callbacks.remove(watch)
    assert where == {threading.main_thread()}
