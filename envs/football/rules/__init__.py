"""The laws of the game: the whistle, restarts, fouls, offside."""
