"""`python -m mocap_metrology` is the command `mocap-metrology`."""

import sys

from mocap_metrology.cli.main import main

if __name__ == "__main__":  # not on import: kernels are sought in all modules
    sys.exit(main())
