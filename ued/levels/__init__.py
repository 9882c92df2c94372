"""Levels: records, queue, buffer, scores, and the teacher that proposes levels."""
