move_hand(to="<sponge>")
grasp_object(item="<sponge>")
while not check_cleanness() or dirty("<table>"):
    wipe_on_plane(tool="<sponge>", place="<table>")
for _ in range(3):
    move_hand()
