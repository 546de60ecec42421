"""Exports scenes from Blender to Mitsuba's format. Only the modules blender_* and `files` need bpy."""
