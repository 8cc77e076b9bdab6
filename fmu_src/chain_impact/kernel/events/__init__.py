"""Events: how a step is searched for them, how they change the state, and the log of contacts."""
