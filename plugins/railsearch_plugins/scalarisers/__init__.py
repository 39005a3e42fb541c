"""Scalarisers: many objectives into one."""
