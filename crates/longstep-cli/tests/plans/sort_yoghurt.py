# Look at the date first.
move_hand()  # move to the yoghurt
grasp_object()  # take the yoghurt; <yoghurt>: inside_hand()
detach_from_plane()  # lift it off the counter
if check_best_by_date():
    move_object()  # move it to the rack
    attach_to_plane()  # put it on the rack; <yoghurt>: on_something(<rack>)
    release_object()
else:
    move_object()  # move it over the trash bin
    release_object()  # drop it; <yoghurt>: inside_something(<trash_bin>)
