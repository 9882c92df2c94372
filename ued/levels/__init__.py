"""Levels: their records, the queue and buffer they wait in, their scores, the teacher that proposes them."""
