"""`regista COMMAND ...`, also as `python -m regista COMMAND ...`. Read next: `regista.experiments.__main__`."""

import sys

from regista.experiments.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
