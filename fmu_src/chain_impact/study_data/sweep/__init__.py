"""The varied values and the table of the runs of a sweep."""
