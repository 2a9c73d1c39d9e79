//! XER files of Primavera P6.

mod tables;
