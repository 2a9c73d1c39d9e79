//! `declare_archive!` and `declare_sections!`: the sections of a kind of archive are declared once, and all that reads, writes and
//! lists them comes from that.
//!
//! ```ignore
//! declare_archive! {
//!     /// Deviations between a site and a SLAM map, read in place.
//!     view Deviations;
//!     /// Records of a `deviations` archive to be.
//!     owned DeviationsBuilder;
//!     sections {
//!         /// What was compared, and how.
//!         pub head: one(1, DeviationsHead),
//!         /// One record per element of the storey, in the order of the site.
//!         pub elements: many(2, ElementDeviationRecord),
//!     }
//! }
//!
//! impl Deviations<'_> {
//!     fn check(&self) -> Result<(), ArchiveError> {
//!         // Called by `open`: indices in range, numbers that are finite, what is sorted.
//!     }
//! }
//! ```
//!
//! Sections are written in the order of the declaration. What is in the brackets is the number in the section table and the type of a
//! record:
//!
//! | section | in an archive | in the view | in the builder |
//! |---|---|---|---|
//! | `one(1, T)` | one record | `&T` | `T` |
//! | `many(1, T)` | any number of records | `&[T]` | `Vec<T>` |
//! | `at_most(1, T, MAX)` | no more than `MAX` | `&[T]` | `Vec<T>` |
//! | `if_any(1, T)` | any number; without records there is no section | `&[T]` | `Vec<T>` |
//! | `utf8(1)` | one text | `&str` | `&str` |
//! | `texts(1)`, `texts(1, listed 2)` | texts of records, and lists of them | `Texts` | `TextPool` |
//! | `group(V, B)` | the sections of `declare_sections!` with view `V` and builder `B` | `V` | `B` |
//! | `optional_group(1, V, B)` | the same, or none of them; section 1 is in every such group | `Option<V>` | `Option<B>` |
//!
//! Of `declare_archive!` come
//!
//! - the view with `open`, which finds the sections, refuses other records, other numbers of them and bytes that are none, and calls
//!   `check`, which is written by hand beside the declaration; and `content_hash`;
//! - the writer: `owned`, a builder that owns its records; `borrowed`, one that borrows them; or `layers`, the layers of a grid, which are
//!   written where they will be read;
//! - `Payload`, with the list of sections: hostile tests, the fuzz target and the layouts of the Python package go through it.
//!
//! The kinds themselves are listed in `archive_kind.rs`.

/// A kind of archive; see the module's documentation.
macro_rules! declare_archive {
    (
        $(#[$view_meta:meta])* view $view:ident;
        $(#[$writer_meta:meta])* $form:ident $writer:ident;
        sections { $($sections:tt)* }
    ) => {
        $crate::declaration::section_view! {
            $(#[$view_meta])* $view |archive| { archive: $crate::archive::Archive<'a> = archive } $($sections)*
        }
        $crate::declaration::section_writer! { $form $(#[$writer_meta])* $writer of $view { $($sections)* } }
        $crate::declaration::archive_writer! { $form $writer of $view }

        impl<'a> $view<'a> {
            /// Validates and views an archive.
            ///
            /// # Errors
            /// Bytes that are no whole archive of this kind, or records that do not fit together.
            pub fn open(bytes: &'a [u8]) -> Result<Self, $crate::archive::ArchiveError> {
                let view = Self::of($crate::archive::Archive::open(bytes, $crate::archive_kind::ArchiveKind::$view)?)?;
                view.check()?;
                Ok(view)
            }

            /// Hash of the content.
            pub fn content_hash(&self) -> $crate::content_hash::ContentHash {
                self.archive.content_hash()
            }
        }

        impl $crate::payload::Payload for $crate::payload::$view {
            const KIND: $crate::archive_kind::ArchiveKind = $crate::archive_kind::ArchiveKind::$view;
            type View<'a> = $view<'a>;

            fn open(bytes: &[u8]) -> Result<$view<'_>, $crate::archive::ArchiveError> {
                $view::open(bytes)
            }

            fn view(bytes: &[u8]) -> Result<$view<'_>, $crate::archive::ArchiveError> {
                $view::of($crate::archive::Archive::open_unhashed(bytes, Self::KIND)?)
            }

            fn sections() -> Vec<$crate::section::Section> {
                $view::sections()
            }
        }
    };
}
pub(crate) use declare_archive;

/// Sections that several kinds have, or that a kind may lack as a whole. Fields of the view that are no sections stand in braces, made
/// from the archive.
macro_rules! declare_sections {
    (
        $(#[$view_meta:meta])* view $view:ident $(|$archive:ident| { $($fields:tt)* })?;
        $(#[$writer_meta:meta])* owned $writer:ident;
        sections { $($sections:tt)* }
    ) => {
        $crate::declaration::section_view! { $(#[$view_meta])* $view $(|$archive| { $($fields)* })? $($sections)* }
        $crate::declaration::section_writer! { owned $(#[$writer_meta])* $writer of $view { $($sections)* } }
    };
}
pub(crate) use declare_sections;

/// The view of sections: reads them, and lists them.
macro_rules! section_view {
    ($(#[$meta:meta])* $view:ident $($(#[$doc:meta])* $vis:vis $name:ident: $shape:ident $args:tt,)*) => {
        $crate::declaration::section_view! {
            $(#[$meta])* $view |archive| {} $($(#[$doc])* $vis $name: $shape $args,)*
        }
    };
    (
        $(#[$meta:meta])* $view:ident |$archive:ident| {
            $($(#[$field_doc:meta])* $field_vis:vis $field:ident: $field_type:ty = $value:expr),* $(,)?
        }
        $($(#[$doc:meta])* $vis:vis $name:ident: $shape:ident $args:tt,)*
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy)]
        pub struct $view<'a> {
            $($(#[$field_doc])* $field_vis $field: $field_type,)*
            $($(#[$doc])* $vis $name: $crate::declaration::section!(view $shape $args),)*
        }

        impl<'a> $view<'a> {
            /// The sections of an archive, without validation of their records.
            pub(crate) fn of($archive: $crate::archive::Archive<'a>) -> Result<Self, $crate::archive::ArchiveError> {
                Ok(Self {
                    $($field: $value,)*
                    $($name: $crate::declaration::section!(read $archive; $shape $args),)*
                })
            }

            /// The sections, in the order in which they are written.
            #[allow(clippy::vec_init_then_push, reason = "a group adds several, after some of the others")]
            pub(crate) fn sections() -> Vec<$crate::section::Section> {
                let mut list = Vec::new();
                $($crate::declaration::section!(list list, stringify!($name); $shape $args);)*
                list
            }
        }
    };
}
pub(crate) use section_view;

/// Records to be written: those that are owned, those that are borrowed, or the layers of a grid.
macro_rules! section_writer {
    (
        owned $(#[$meta:meta])* $writer:ident of $view:ident {
            $($(#[$doc:meta])* $vis:vis $name:ident: $shape:ident $args:tt,)*
        }
    ) => {
        $crate::declaration::section_writer! {
            records owned [] [] $(#[$meta])* $writer of $view { $($(#[$doc])* $vis $name: $shape $args,)* }
        }

        /// Nothing: a record of zeros where there is one, no others.
        impl Default for $writer {
            fn default() -> Self {
                Self { $($name: $crate::declaration::section!(nothing $shape),)* }
            }
        }
    };
    (borrowed $($declared:tt)*) => {
        $crate::declaration::section_writer! { records borrowed [<'a>] [<'_>] $($declared)* }
    };
    (
        records $form:ident [$($generics:tt)*] [$($elided:tt)*] $(#[$meta:meta])* $writer:ident of $view:ident {
            $($(#[$doc:meta])* $vis:vis $name:ident: $shape:ident $args:tt,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        pub struct $writer $($generics)* {
            $($(#[$doc])* pub $name: $crate::declaration::section!($form $shape $args),)*
        }

        impl $writer $($elided)* {
            pub(crate) fn add_to<'l>(&'l self, list: &mut $crate::archive::SectionList<'l>) {
                $($crate::declaration::section!(add list, self.$name; $shape $args);)*
            }
        }
    };
    (
        layers $(#[$meta:meta])* $writer:ident of $view:ident {
            $(#[$head_doc:meta])* $head_vis:vis $head:ident: one($head_id:literal, $head_type:ty),
            $($(#[$doc:meta])* $vis:vis $layer:ident: $shape:ident($id:literal, $cell:ty),)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        pub struct $writer<'a> {
            $($(#[$doc])* pub $layer: &'a mut [$cell],)*
        }

        impl<'a> $writer<'a> {
            /// Head and layers.
            const N_SECTIONS: usize = 1 + [$(stringify!($layer)),*].len();
            /// Head and the layers that every grid has; they come first.
            const N_ALWAYS: usize = 1 $(+ $crate::declaration::section!(always $shape))*;

            /// The sections of a grid of so many cells.
            fn layouts(n_cells: usize) -> [$crate::archive::SectionLayout; $writer::N_SECTIONS] {
                use $crate::archive::SectionLayout;
                let (record_len, count) = (size_of::<$head_type>(), 1);
                let head = SectionLayout { id: $head_id, record_len, count };
                [head, $(SectionLayout { id: $id, record_len: size_of::<$cell>(), count: n_cells }),*]
            }

            /// The layers in memory with sections in these places.
            fn of(memory: &'a mut [u8], sections: &[std::ops::Range<usize>; $writer::N_SECTIONS]) -> Self {
                let sections = memory.get_disjoint_mut(sections.clone()).expect("sections lie beside each other");
                let [_, $($layer),*] = sections;
                Self { $($layer: bytemuck::cast_slice_mut($layer)),* }
            }
        }

        impl $view<'_> {
            /// Cells of each layer; zero of one that is not there.
            fn layer_lengths(&self) -> [usize; $writer::N_SECTIONS - 1] {
                [$(self.$layer.len()),*]
            }
        }
    };
}
pub(crate) use section_writer;

/// The writer of an archive from its records.
macro_rules! archive_writer {
    (layers $writer:ident of $view:ident) => {};
    (owned $writer:ident of $view:ident) => {
        $crate::declaration::archive_writer! { records $writer of $view }
    };
    (borrowed $writer:ident of $view:ident) => {
        $crate::declaration::archive_writer! { records $writer<'_> of $view }
    };
    (records $writer:ident $(<$elided:lifetime>)? of $view:ident) => {
        impl $writer $(<$elided>)? {
            /// Writes the archive into the heap.
            pub fn finish(&self) -> $crate::archive::ArchiveBuffer {
                $crate::archive_writer::ArchiveWriter::to_buffer(self)
            }

            fn sections(&self) -> $crate::archive::SectionList<'_> {
                let mut list = $crate::archive::SectionList::default();
                self.add_to(&mut list);
                list
            }
        }

        impl $crate::archive_writer::ArchiveWriter for $writer $(<$elided>)? {
            type Payload = $crate::payload::$view;

            fn length(&self) -> usize {
                self.sections().length()
            }

            fn write(&self, out: &mut [u8]) -> $crate::content_hash::ContentHash {
                self.sections().write(out, $crate::archive_kind::ArchiveKind::$view)
            }
        }
    };
}
pub(crate) use archive_writer;

/// What a section is: its type in the view and in the builder, how it is read, written and listed.
macro_rules! section {
    (view one($id:literal, $record:ty)) => { &'a $record };
    (owned one($id:literal, $record:ty)) => { $record };
    (borrowed one($id:literal, $record:ty)) => { $record };
    (read $archive:ident; one($id:literal, $record:ty)) => { $archive.record($id)? };
    (add $list:ident, $records:expr; one($id:literal, $record:ty)) => {
        $list.add($id, std::slice::from_ref(&$records))
    };
    (list $list:ident, $name:expr; one($id:literal, $record:ty)) => {
        $list.push($crate::section::Section::of::<$record>($name, $id, $crate::section::SectionCount::One))
    };

    (read $archive:ident; many($id:literal, $record:ty)) => { $archive.section($id)? };
    (add $list:ident, $records:expr; many($id:literal, $record:ty)) => { $list.add::<$record>($id, &$records) };
    (list $list:ident, $name:expr; many($id:literal, $record:ty)) => {
        $list.push($crate::section::Section::of::<$record>($name, $id, $crate::section::SectionCount::Any))
    };

    (read $archive:ident; at_most($id:literal, $record:ty, $max:expr)) => { $archive.section_of_at_most($id, $max)? };
    (add $list:ident, $records:expr; at_most($id:literal, $record:ty, $max:expr)) => {
        $list.add::<$record>($id, &$records)
    };
    (list $list:ident, $name:expr; at_most($id:literal, $record:ty, $max:expr)) => {
        $list.push($crate::section::Section::of::<$record>($name, $id, $crate::section::SectionCount::AtMost($max)))
    };

    (read $archive:ident; if_any($id:literal, $record:ty)) => { $archive.optional_section($id)? };
    (add $list:ident, $records:expr; if_any($id:literal, $record:ty)) => {
        $list.add_if_any::<$record>($id, &$records)
    };
    (list $list:ident, $name:expr; if_any($id:literal, $record:ty)) => {
        $list.push($crate::section::Section::of::<$record>($name, $id, $crate::section::SectionCount::Any).optional())
    };

    (view utf8($id:literal)) => { &'a str };
    (borrowed utf8($id:literal)) => { &'a str };
    (read $archive:ident; utf8($id:literal)) => { $archive.strings($id)? };
    (add $list:ident, $text:expr; utf8($id:literal)) => { $list.add($id, $text.as_bytes()) };
    (list $list:ident, $name:expr; utf8($id:literal)) => {
        $list.push($crate::section::Section::of::<u8>($name, $id, $crate::section::SectionCount::Any))
    };

    (view texts($id:literal $(, listed $listed:literal)?)) => { $crate::text_pool::Texts<'a> };
    (owned texts($id:literal $(, listed $listed:literal)?)) => { $crate::text_pool::TextPool };
    (read $archive:ident; texts($id:literal)) => { $crate::text_pool::Texts::of($archive, $id)? };
    (read $archive:ident; texts($id:literal, listed $listed:literal)) => {
        $crate::text_pool::Texts::with_lists($archive, $id, $listed)?
    };
    (add $list:ident, $texts:expr; texts($id:literal $(, listed $listed:literal)?)) => {
        $($list.add($listed, $texts.listed());)?
        $list.add($id, $texts.bytes())
    };
    (list $list:ident, $name:expr; texts($id:literal $(, listed $listed:literal)?)) => {
        $($crate::declaration::section!(list $list, "listed_texts"; many($listed, $crate::archive::Text));)?
        $crate::declaration::section!(list $list, "strings"; utf8($id))
    };

    (view group($view:ident, $writer:ident)) => { $view<'a> };
    (owned group($view:ident, $writer:ident)) => { $writer };
    (read $archive:ident; group($view:ident, $writer:ident)) => { $view::of($archive)? };
    (add $list:ident, $records:expr; group($view:ident, $writer:ident)) => { $records.add_to($list) };
    (list $list:ident, $name:expr; group($view:ident, $writer:ident)) => { $list.extend($view::sections()) };

    (view optional_group($first:literal, $view:ident, $writer:ident)) => { Option<$view<'a>> };
    (owned optional_group($first:literal, $view:ident, $writer:ident)) => { Option<$writer> };
    (read $archive:ident; optional_group($first:literal, $view:ident, $writer:ident)) => {
        if $archive.has($first) { Some($view::of($archive)?) } else { None }
    };
    (add $list:ident, $records:expr; optional_group($first:literal, $view:ident, $writer:ident)) => {
        if let Some(records) = &$records {
            records.add_to($list);
        }
    };
    (list $list:ident, $name:expr; optional_group($first:literal, $view:ident, $writer:ident)) => {
        $list.extend($crate::section::Section::optional_group($name, $view::sections()))
    };

    // Layers that every grid has, counted.
    (always many) => { 1 };
    (always if_any) => { 0 };

    (nothing one) => { bytemuck::Zeroable::zeroed() };
    (nothing $shape:ident) => { Default::default() };

    // The types of `many`, `at_most` and `if_any`.
    (view $rows:ident($id:literal, $record:ty $(, $max:expr)?)) => { &'a [$record] };
    (owned $rows:ident($id:literal, $record:ty $(, $max:expr)?)) => { Vec<$record> };
    (borrowed $rows:ident($id:literal, $record:ty $(, $max:expr)?)) => { &'a [$record] };
}
pub(crate) use section;
