"""The flow and its derivatives in numpy, with which the kernel is compared."""
