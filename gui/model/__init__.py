"""What the application knows, without any widget or picture."""
