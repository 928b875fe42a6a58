"""`python -m mocap_metrology` is the command `mocap-metrology`."""

import sys

from mocap_metrology.cli.main import main

sys.exit(main())
