"""Tests send signals: what runs them in the background may have had Ctrl-C ignored, and commands heed that (nohup)."""

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
