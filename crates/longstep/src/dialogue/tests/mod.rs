mod injected;
mod large;
mod parts;
mod requests;
mod trees;
