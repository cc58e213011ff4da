"""What there is to say about a recording or a result, as data: codes with their severity, meaning and advice."""

from flex_ident.notices.codes import Code, Severity
from flex_ident.notices.notice import Notice
from flex_ident.notices.reasons import Reason, Why

__all__ = ["Code", "Notice", "Reason", "Severity", "Why"]
