#! id: broken_width
#! kind: error
#! tags: a width that is no number
ego = new Object at 0 @ 0, with width 'wide'
