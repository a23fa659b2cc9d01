mod injected;
mod large;
mod requests;
