"""The results for a user: labelled datasets, their files and the merged study."""
