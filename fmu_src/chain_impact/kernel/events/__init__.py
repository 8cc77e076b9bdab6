"""Events: the search of a step for events, their effects on the state, and the log of contacts."""
