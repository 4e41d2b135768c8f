"""Results on disk: the scene as JSON, history, summary, states, checkpoints, and frames for ParaView."""
