"""What players do to the ball and to each other: touches, kicks, saves, tackles."""
