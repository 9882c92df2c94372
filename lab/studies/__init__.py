"""Studies of many games over seeds, and the tables of their stored rows; see `lab.studies.__main__`."""
