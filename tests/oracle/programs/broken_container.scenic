#! id: broken_container
#! kind: error
#! tags: outside its region
ego = new Object at 9 @ 9, with regionContainedIn CircularRegion(0 @ 0, 5)
