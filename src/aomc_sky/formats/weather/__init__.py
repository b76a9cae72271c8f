"""Hourly weather files: EPW, TMY2 and TMY3.

heads  Heads of EPW, TMY2 and TMY3 files: where the station stands, and how a row is cut into its texts
hours  Hourly weather files: EPW, TMY2 and TMY3. When each hour began, and its irradiances
"""
