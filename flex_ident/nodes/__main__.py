"""`python -m flex_ident.nodes NODE`."""

import sys

from flex_ident.nodes.starting import main

sys.exit(main())
