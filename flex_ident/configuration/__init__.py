"""Adapter: settings of commands and nodes, from one table, on the command line and in ROS 2 parameter files."""

from flex_ident.configuration.files import read_settings
from flex_ident.configuration.settings import GAP_SETTINGS, IDENTIFY_SETTINGS, IMPORT_SETTINGS, Setting

__all__ = ["GAP_SETTINGS", "IDENTIFY_SETTINGS", "IMPORT_SETTINGS", "Setting", "read_settings"]
