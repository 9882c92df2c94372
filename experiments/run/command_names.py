"""The commands with one-line descriptions. Read next: `__main__`, which runs them."""

COMMANDS = {
    "train": "train students on a game or a task, with or without a curriculum",
    "evaluate": "evaluate trained runs on test scenes, with intervals; --gallery: page of levels",
    "compare": "train several methods over seeds, evaluate them, write tables and pictures",
    "inspect": "show a program or a task: its free parameters, random levels, its syntax",
    "list": "show the minigames, published results, test scenes; --solved: how hard they are",
    "play": "play a match or a level of a run, and write a video or a record; --replay: replay a record",
    "demonstrate": "save episodes of a program or of a student as demonstrations",
    "clone": "train a student on demonstrations (behavior cloning)",
    "transfer": "compare trained runs in our simulator and in Google Research Football",
    "benchmark": "measure the speed of the simulator and of training",
    "completion": "print a script that completes commands and flags in bash, zsh or fish",
}
