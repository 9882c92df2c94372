"""Access to Rerun's writer with a time limit, since Rerun hangs after a disk failure.

Rerun can block forever in `set_sinks`, `flush` and `disconnect`, when a stream is freed, and at exit.
Read next: `recorder`.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import rerun

from ued.core.files import partial_of

PATIENCE = 60.0  # s, time limit for writing pending data
COMPACTED = 256_000_000  # bytes; larger files are not compacted, since this takes several times their size in memory


class Writer:
    """A stream's writer. It is finished at exit at the latest."""

    def __init__(self, stream: rerun.RecordingStream) -> None:
        self.stream = stream
        atexit.register(self._end)

    def wait_for(self, act: Callable[[], object]) -> None:
        """Call a function that waits for the writer.

        Raises the errors of `act`, and RuntimeError after the time limit. After an error, the stream is never freed or
        waited for again.
        """
        failure: list[Exception] = [RuntimeError(f"the writer did not respond within {PATIENCE:.0f} s")]

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
        """End the stream. Raises the errors of `wait_for`."""
        self.wait_for(self.stream.disconnect)
        atexit.unregister(self._end)

    def _end(self) -> None:
        with suppress(Exception):
            self.finish()


def compact(path: Path, application: str, recording_id: str, views: Any) -> None:
    """Merge the chunks of a complete file, which has a chunk of kilobytes for each entity and flush.

    Args:
        path: the file, which is replaced atomically.
        application, recording_id: names of the recording.
        views: blueprint of the recording.

    Large files are not changed. Raises OSError or RuntimeError if the new file cannot be written; the old file stays.
    """
    from rerun.chunk import OptimizationProfile, RrdReader

    if path.stat().st_size > COMPACTED:
        return
    merged = RrdReader(str(path)).stream().collect(optimize=OptimizationProfile.OBJECT_STORE)
    stream = rerun.RecordingStream(application, recording_id=recording_id, send_properties=False)
    partial, writer = partial_of(path), Writer(stream)
    try:
        with open(partial, "wb"):  # Rerun only warns about an unwritable path
            pass
        writer.wait_for(lambda: stream.save(partial, default_blueprint=views))
        stream.send_chunks(merged)
        writer.finish()
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
