#! id: broken_key
#! kind: error
#! tags: missing key
sizes = {'small': 1, 'big': 3}
ego = new Object at 0 @ 0, with width sizes['huge']
