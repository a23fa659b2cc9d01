# objects: ["<milk>"]
move_hand()  # move to the milk
grasp_object()  # take it; <milk>: inside_hand()
detach_from_plane()
if check_best_by_date():
    move_object(to="<table>")
    attach_to_plane()
    release_object()
else:
    move_object(to="<bin>")
    release_object()
