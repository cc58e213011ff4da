"""Names of the public JSON forms."""

RESULT = "flex_ident/result/1"
GAP = "flex_ident/gap/1"
