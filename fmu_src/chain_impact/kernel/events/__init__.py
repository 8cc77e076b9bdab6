"""Events: the search of a step for events, the effects of events on the state, and the log of contacts."""
