"""Trajectories for the programs of others: servo tables, ROS 2 messages, Rerun recordings, and the swimmer as URDF.

A limb's joint becomes hinges here; joints and frames have the same names in all of them. Imports the floors below.
"""
