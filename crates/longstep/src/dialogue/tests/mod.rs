mod goals;
mod injected;
mod large;
mod likelihood;
mod parts;
mod requests;
mod trees;
