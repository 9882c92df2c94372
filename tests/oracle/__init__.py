"""The golden oracle: small Scenic programs, what real Scenic makes of them, and what we make of them.

A program is a `.scenic` file of `programs/` (or of any other folder) whose first lines `#! key: value; key: value` say
how it is to be run:

    id      its name, that of the file
    kind    static   sample `n` scenes and compare the distribution of everything in them
            error    load, sample one scene, and with `run: dynamic` simulate; compare the place of the error
            dynamic  simulate
    tags    what it covers
    n       how many scenes; 300 to 500 tell most mistakes and keep the files small
    props   properties of the objects to compare beside x, y and heading, separated by commas

To add a program: put the file there, run it under real Scenic 3 and 2 with the script that came with the language's
specification, and merge what that wrote into the expected files (`merge` drops what the comparison does not need):

    python oracle.py run --dialect 3 tests/oracle/programs --only NAME -o new.json
    python -m tests.oracle merge new.json tests/oracle/programs/expected_scenic3.json

`python -m tests.oracle FOLDER --dialect 3 -o FILE` writes our side in the same shape, and
`python -m tests.oracle compare EXPECTED FILE` says where they differ. Read next: `runner`, `static`, `errors`.
"""
