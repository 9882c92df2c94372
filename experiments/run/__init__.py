"""Parts of a run: settings, objects, folder, tables, workers."""
