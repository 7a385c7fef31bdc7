"""From a case to its file: runs, checkpoints, batches, the workflow and their resources."""
