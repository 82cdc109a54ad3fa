"""An interactive window onto models."""
