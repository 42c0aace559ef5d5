"""What a plan meets: its controls on another swimmer than the one it was made for.

Imports `verification`, `files`, `motion`, `mechanics`, `geometry`.
"""
