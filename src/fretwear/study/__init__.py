"""What a user asks for: cases, study files and their plan of points."""
