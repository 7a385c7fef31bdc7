"""The request of a user: cases, study files and the plan of their points."""
