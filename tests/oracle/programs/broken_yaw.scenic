#! id: broken_yaw
#! kind: error
#! tags: facing and with yaw
ego = new Object facing 10 deg, with yaw 20 deg
