"""Rerun's writer, which answers no more where the disk has failed it: whoever waits for it does so with a limit.

Rerun waits without end in `set_sinks`, `flush` and `disconnect`, when a stream is freed, and at the end of the program.
Read next: `recorder`.
"""

from __future__ import annotations

import atexit
import ctypes
import threading
from collections.abc import Callable
from contextlib import suppress

import rerun

PATIENCE = 60.0  # s that the disk may take for what is pending


class Writer:
    """A stream's writer. It is finished at the end of the program, if nobody has finished it before."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self.stream = stream
        atexit.register(self._end)

    def wait_for(self, act: Callable[[], object]) -> None:
        """Do what waits for the writer.

        Raises what it raises, RuntimeError if it takes too long. Then the stream is never freed, nor waited for again.
        """
        failure: list[Exception] = [RuntimeError(f"its writer has not answered for {PATIENCE:.0f} s")]

        def wait() -> None:
            try:
                act()
                failure.clear()
            except Exception as error:
                failure[:] = [error]

        waiting = threading.Thread(target=wait, daemon=True)
        waiting.start()
        waiting.join(PATIENCE)
        if failure:
            atexit.unregister(self._end)
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(self.stream))
            rerun.unregister_shutdown()
            raise failure[0]

    def finish(self) -> None:
        """End the stream. Raises what `wait_for` does."""
        self.wait_for(self.stream.disconnect)
        atexit.unregister(self._end)

    def _end(self) -> None:
        with suppress(Exception):
            self.finish()
