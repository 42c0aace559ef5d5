"""Short plans found offline, recalled and scaled for near goals.

Holds the stored plan library and random short plans. Part of the planner.
"""
