"""What a run is made of: settings, objects, folder, tables, workers."""
