"""The simulator beside other libraries, in the same process and in turn."""
