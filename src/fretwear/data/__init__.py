"""What a user gets: labelled datasets, their files and the merged study."""
