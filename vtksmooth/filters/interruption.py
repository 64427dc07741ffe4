"""Ctrl-C, and the end of the interpreter, while filters run inside VTK.

VTK calls filters and observers from C++, where Python's exceptions end: a KeyboardInterrupt that is raised in
a filter is printed and forgotten, and one that is raised in an observer ends the process. A thread that comes
back from C++ while the interpreter ends makes the process abort.
"""

from __future__ import annotations

import _thread
import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase

from ..errors import Cancelled

#: Ctrl-C pressed again after this time, seconds, interrupts at once: what runs does not stop by itself.
_PATIENCE = 2.0
#: How long the end of the interpreter waits for running filters to stop, and these for the end, seconds.
_LONGEST_END = 10.0

#: When Ctrl-C was pressed while a filter was running in the main thread.
_pressed: float | None = None
#: The thread that ends the interpreter, once it does.
_ender: int | None = None
#: Threads that run filters; one that runs a filter within a filter is there twice.
_threads: list[int] = []
_left = threading.Condition()


@contextmanager
def running(called_by_vtk: bool) -> Iterator[None]:
    """While this context is open, a filter runs in this thread: Ctrl-C waits for a place where it can stop.

    Left in the main thread after Ctrl-C, the context raises KeyboardInterrupt; where C++ is the caller,
    Python raises it as soon as VTK has returned. Handlers other than Python's own stay in place.

    Parameters
    ----------
    called_by_vtk : bool
        Whether it is C++ that waits for what is within the context.

    Raises
    ------
    Cancelled
        The interpreter ends.
    """
    global _pressed
    me = threading.get_ident()
    if not called_by_vtk:
        check()
    with _left:
        _threads.append(me)
    main = threading.current_thread() is threading.main_thread()
    holding = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if holding:
        signal.signal(signal.SIGINT, _hold)
    try:
        yield
    finally:
        with _left:
            _threads.remove(me)
            _left.notify_all()
        if _ended_elsewhere() and called_by_vtk and me not in _threads:
            time.sleep(_LONGEST_END)  # not back into C++, from where there is no way into a dead interpreter
        if holding:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            interrupted, _pressed = _pressed is not None, None
            if interrupted and called_by_vtk:
                threading.Thread(target=_interrupt, args=_caller_of_vtk(), daemon=True).start()
            elif interrupted:
                raise KeyboardInterrupt


def check() -> None:
    """Raise KeyboardInterrupt after Ctrl-C, and Cancelled while the interpreter ends."""
    if _ended_elsewhere():
        raise Cancelled("The run was stopped because the program ends.")
    if _pressed is not None and threading.current_thread() is threading.main_thread():
        raise KeyboardInterrupt


def _ended_elsewhere() -> bool:
    """Return whether another thread ends the interpreter; that one may run filters to the last."""
    return _ender is not None and _ender != threading.get_ident()


def _hold(number: int, frame: FrameType | None) -> None:
    global _pressed
    now = time.monotonic()
    if _pressed is not None and now - _pressed > _PATIENCE:
        signal.default_int_handler(number, frame)
    _pressed = now if _pressed is None else _pressed


def _caller_of_vtk() -> tuple[FrameType | None, int]:
    """Return what has called VTK, which has called this, and the place in it."""
    entrance = VTKPythonAlgorithmBase.InternalAlgorithm.ProcessRequest.__code__
    frame: FrameType | None = sys._getframe()
    while frame is not None and frame.f_code is not entrance:
        frame = frame.f_back
    caller = None if frame is None else frame.f_back
    return caller, -1 if caller is None else caller.f_lasti


def _interrupt(caller: FrameType | None, place: int) -> None:
    """Interrupt the main thread once `caller` goes on: before, the exception would be lost in VTK."""
    main = threading.main_thread().ident or 0

    def waits() -> bool:
        frame = sys._current_frames().get(main)
        while frame is not None and frame is not caller:
            frame = frame.f_back
        return frame is not None and frame.f_lasti == place

    while waits():
        time.sleep(0.001)
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()


@atexit.register
def _stop_all() -> None:
    """Ask the filters that daemon threads run to stop and wait for them; Python has waited for the others."""
    global _ender
    _ender = me = threading.get_ident()
    with _left:
        _left.wait_for(lambda: all(thread == me for thread in _threads), _LONGEST_END)


def _begin_in_child() -> None:
    global _left
    _left = threading.Condition()  # a thread that is not here may have held the old one
    _threads[:] = [thread for thread in _threads if thread == threading.get_ident()]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_in_child)
