"""Recordings on disk: the file of a shot, the series, angle series, reading and writing."""
