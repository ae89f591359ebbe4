"""What scripts/events runs: the pendulum with hard friction, integrated from event to event."""
