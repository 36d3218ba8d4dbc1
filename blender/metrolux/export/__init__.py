"""From Blender's scene to a scene of Mitsuba."""
