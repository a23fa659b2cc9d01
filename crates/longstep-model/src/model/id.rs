//! Ids: typed indexes into a list.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u16);

        impl $name {
            /// The id of the entry at `index` in its list.
            pub fn new(index: usize) -> Self {
                debug_assert!(index <= usize::from(u16::MAX));
                Self(index as u16)
            }

            /// Returns the index in its list.
            pub fn index(self) -> usize {
                usize::from(self.0)
            }
        }
    };
}
pub(crate) use id;
