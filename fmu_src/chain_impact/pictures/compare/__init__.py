"""The picture of a comparison of contact laws."""
